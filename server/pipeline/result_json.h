#pragma once
// How results look as JSON. The keys are a contract: keys are added, never renamed.
#include <nlohmann/json.hpp>

#include "common/change/region.h"
#include "common/program/json_output.h"
#include "server/pipeline/examiner.h"
#include "server/store/scene_store.h"

namespace meshloop {

[[nodiscard]] nlohmann::json counts_json(const Comparison& comparison);
[[nodiscard]] nlohmann::json region_json(const Region& region);
[[nodiscard]] nlohmann::json times_json(const Examination& examination);
[[nodiscard]] nlohmann::json revision_json(const RevisionInfo& info);

}  // namespace meshloop
