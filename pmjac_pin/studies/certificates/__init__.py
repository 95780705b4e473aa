"""Certificates: proofs that a closed pose exists near a computed one, by interval arithmetic."""
