//! Calibrated cameras.
