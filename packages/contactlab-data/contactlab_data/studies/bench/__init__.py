"""A bench of contact laws: questions with exact answers, put to any law and to other simulators alike."""
