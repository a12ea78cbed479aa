"""What a scene's program holds of each effect, found in the program itself: `plan --audit`."""
