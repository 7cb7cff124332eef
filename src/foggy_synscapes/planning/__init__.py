"""What an experiment will run, need and cost, said before anything runs."""
