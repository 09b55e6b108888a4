// The action server of a gripper on Fast DDS, the default DDS of ROS 2.
//
// fast_dds_gripper DOMAIN ACTION: for each goal, it prints its number of bytes,
// position and force, and publishes that it executes and that it succeeded.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <string>
#include <thread>
#include <vector>

namespace fast = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using Bytes = std::vector<unsigned char>;

constexpr unsigned char kExecuting = 2, kSucceeded = 4;
constexpr int kGoal = 4, kPosition = 20, kForce = 28;  // After CDR's prefix.

// A message as its bytes.
class Raw : public fast::TopicDataType {
 public:
  explicit Raw(const char* name) {
    setName(name);
    m_typeSize = 4096;
    m_isGetKeyDefined = false;
  }
  bool serialize(void* data, rtps::SerializedPayload_t* out) override {
    const auto& bytes = *static_cast<Bytes*>(data);
    std::memcpy(out->data, bytes.data(), bytes.size());
    out->length = bytes.size();
    out->encapsulation = CDR_LE;
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* in, void* data) override {
    static_cast<Bytes*>(data)->assign(in->data, in->data + in->length);
    return true;
  }
  std::function<uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return uint32_t(static_cast<Bytes*>(data)->size()); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

double number(const Bytes& message, int at) {
  double value;
  std::memcpy(&value, &message[at], sizeof value);
  return value;
}

int main(int, char** arguments) {
  const std::string action = arguments[2];
  auto* participant =
      fast::DomainParticipantFactory::get_instance()->create_participant(
          std::atoi(arguments[1]), fast::PARTICIPANT_QOS_DEFAULT);
  fast::TypeSupport request(new Raw(
      "control_msgs::action::dds_::GripperCommand_SendGoal_Request_"));
  fast::TypeSupport states(new Raw("action_msgs::msg::dds_::GoalStatusArray_"));
  request.register_type(participant);
  states.register_type(participant);
  auto* requests_topic = participant->create_topic(
      "rq/" + action + "/_action/send_goalRequest", request.get_type_name(),
      fast::TOPIC_QOS_DEFAULT);
  auto* states_topic = participant->create_topic(
      "rt/" + action + "/_action/status", states.get_type_name(),
      fast::TOPIC_QOS_DEFAULT);
  auto reliable = fast::DATAREADER_QOS_DEFAULT;
  reliable.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  auto latched = fast::DATAWRITER_QOS_DEFAULT;
  latched.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
  latched.durability().kind = fast::TRANSIENT_LOCAL_DURABILITY_QOS;
  auto* reader = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT)
                     ->create_datareader(requests_topic, reliable);
  auto* writer = participant->create_publisher(fast::PUBLISHER_QOS_DEFAULT)
                     ->create_datawriter(states_topic, latched);
  for (;;) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    Bytes goal;
    fast::SampleInfo info;
    while (reader->take_next_sample(&goal, &info) ==
           eprosima::fastrtps::types::ReturnCode_t::RETCODE_OK) {
      if (!info.valid_data) continue;
      std::printf("%zu %g %g\n", goal.size(), number(goal, kPosition),
                  number(goal, kForce));
      std::fflush(stdout);
      for (unsigned char state : {kExecuting, kSucceeded}) {
        Bytes message = {0, 1, 0, 0, 1, 0, 0, 0};  // CDR, one goal.
        message.insert(message.end(), &goal[kGoal], &goal[kPosition]);
        message.insert(message.end(), 8, 0);  // The time of its acceptance.
        message.push_back(state);
        writer->write(&message);
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      }
    }
  }
}
