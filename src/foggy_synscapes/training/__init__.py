"""Training: policies, losses, augmentation, order of samples, snapshots and the loop. Nothing here knows a path."""
