"""The live map: frames of the wrist camera, and what is made of them."""
