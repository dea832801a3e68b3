"""Training data at scale: scans with ground truth in shards that loaders of neural networks can stream.

Read `generation_config` (the settings), `sample_plan` (which sample is what), `sample_making` (one sample),
`training_sample` (its files), then `generation_plan` (the tasks), `shard_task` (what a worker does),
`generate` (one call from settings to folder), `generated_folder` (what lies there) and `datasheet`.
`shard_reading` reads the shards again. The TOML files are the packaged settings.

`sample_plan`, `sample_making` and `training_sample` decide the samples; the rest decides where and when they
are made.
"""

from evaluation.generation.generate import generate
from evaluation.generation.generation_config import GenerationConfig
from evaluation.generation.sample_making import make_sample
from evaluation.generation.shard_reading import read_shard, read_shards
from evaluation.generation.training_sample import TrainingSample

__all__ = ["GenerationConfig", "TrainingSample", "generate", "make_sample", "read_shard", "read_shards"]
