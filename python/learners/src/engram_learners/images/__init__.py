"""What the cameras see: a detector of objects, and environments whose rows come from it."""
