"""From a map, or from a measured probe, to a rig."""
