"""What of a law is free, and the values of it that measurements are met best with."""
