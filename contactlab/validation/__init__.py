"""Laws against measured impacts: fitted on one part of them, judged on another."""
