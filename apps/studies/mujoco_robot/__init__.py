"""The stand-in's robot with MuJoCo's dynamics in place of Drake's."""
