#include "core/base/json.h"

namespace nlohmann {
VITRINE_JSON_TEMPLATES(, json)
VITRINE_JSON_TEMPLATES(, ordered_json)
}  // namespace nlohmann
