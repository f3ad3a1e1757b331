"""Nine memories in one plain policy: imitation, PPO, and tables that compare them."""
