"""Numbers of laws and motors from what was measured: the best, their posterior, and evidence between laws."""
