"""Medial diffusion [Berger & Silva 2012] and its baselines, on oriented point clouds."""

from medial.diffusion import Diffusion

__all__ = ["Diffusion"]
