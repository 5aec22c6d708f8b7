#pragma once
/// Parts of a Monte Carlo as files: N processes or machines draw one part each, and one joins them.
///
///   {"format": "procam-draws", "version": 1, "seed": 1, "draws": 8000000, "shard": 2, "shards": 8,
///    "surfaces": [{"name": "wall", "rms_mm": 3.1, "points": [null, [draws, missed, mean x, mean y, xx, xy, yy,
///    worst], ...]}]}
///
/// Metres; `shard` counts from 1; `rms_mm` is that of the closed form, by which a part of other inputs is noticed; null: a
/// point that no light reaches.
#include <filesystem>
#include <vector>

#include "procam/analyze/prediction.hpp"
#include "procam/core/base/export.hpp"

namespace procam::report {

/// The draws of the surfaces, made with these options, as the text of such a file.
PROCAM_EXPORT std::string draws_to_json(const std::vector<analyze::SurfacePrediction>& surfaces,
                                        const analyze::MonteCarloOptions& options);

/// Sets the draws of the surfaces to those of all parts. Throws Error(kInput) for a file that is no such part or of other
/// inputs, another seed or another number of draws, and for a part that is missing or given twice; Error(kIo).
PROCAM_EXPORT void merge_draws(const std::vector<std::filesystem::path>& files,
                               std::vector<analyze::SurfacePrediction>& surfaces);

}  // namespace procam::report
