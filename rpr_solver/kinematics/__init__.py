"""Direct kinematics: all poses of one joint vector."""
