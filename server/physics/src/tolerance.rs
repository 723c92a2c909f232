//! Every threshold, with its reason. Nothing else in the engine compares against a number of its own.
