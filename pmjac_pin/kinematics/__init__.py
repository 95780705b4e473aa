"""Kinematics: poses, motions and rows as functions of numbers, and at one pose by Pinocchio."""
