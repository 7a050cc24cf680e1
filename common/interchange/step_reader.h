#pragma once
// Built with -DMESHLOOP_STEP=ON only.
#include "common/interchange/read_file.h"

namespace meshloop {

/// The triangles of a STEP file's faces lie at most this far from them, and turn by at most kStepAngle_rad from one to
/// the next.
inline constexpr double kStepDeflection_m = 0.0002;
inline constexpr double kStepAngle_rad = 0.35;

/// A FormatReader for STEP (ISO 10303-21), tessellated by OpenCASCADE: one part a solid, or a free shell. The file
/// states its unit.
[[nodiscard]] Result<ReadParts> read_step(const std::filesystem::path& file, const Progress& progress);

}  // namespace meshloop
