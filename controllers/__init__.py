"""Control, guidance and allocation: arrays in, arrays out; no MuJoCo here."""
