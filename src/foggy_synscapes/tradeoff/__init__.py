"""What cheaper ways of computing save and what they cost: measured, compared, and put into words."""
