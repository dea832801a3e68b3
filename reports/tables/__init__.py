"""Tables, the leaderboard and paired tests."""
