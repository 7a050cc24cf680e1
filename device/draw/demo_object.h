#pragma once
#include "common/mesh/submesh.h"

namespace meshloop {

/// A toy lighthouse with vertex colours, to be put onto something real: it stands on z = 0 at the origin, z up, its
/// door towards -y. Closed except for its underside; front faces outside.
[[nodiscard]] Submesh make_lighthouse(double height_m = 0.18);

}  // namespace meshloop
