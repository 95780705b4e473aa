"""Studies: functions that ask a question of a mechanism or of a configuration."""
