#include "client/terminal/remarks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <string_view>

namespace lucerna::cli {
namespace {

/// A group of remarks: the beginnings of their two texts, and the words for one remark and for
/// several.
struct RemarkGroup {
  std::string_view what, instead;
  std::string_view one;
  std::string_view many;
};

constexpr RemarkGroup kGroups[] = {
    {"Shape ", "left out", "surface left out", "surfaces left out"},
    {"mesh ", "left out", "surface left out", "surfaces left out"},
    {"material ", "", "material taken as diffuse", "materials taken as diffuse"},
    {"texture ", "constant ", "texture taken as constant", "textures taken as constant"},
    {"", "grey ", "colour taken as grey", "colours taken as grey"},
    {"", "clamped to ", "reflectance clamped", "reflectances clamped"},
    {"", "opaque", "surface taken as opaque", "surfaces taken as opaque"},
    {"", "vacuum", "medium taken as vacuum", "media taken as vacuum"},
    {"", "", "other remark", "other remarks"},
};

}  // namespace

std::string describe(const v1::Remark& remark) {
  std::string place = remark.file();
  if (remark.line() > 0) place += fmt::format(":{}:{}", remark.line(), remark.column());
  if (remark.count() > 1)
    place += fmt::format(" and {} more {}", remark.count() - 1,
                         remark.count() == 2 ? "place" : "places");
  return fmt::format("{}: {}; {}", place, remark.what(), remark.instead());
}

std::string count_remarks(const google::protobuf::RepeatedPtrField<v1::Remark>& remarks) {
  std::uint64_t counts[std::size(kGroups)] = {};
  for (const v1::Remark& remark : remarks) {
    std::size_t group = 0;
    while (!remark.what().starts_with(kGroups[group].what) ||
           !remark.instead().starts_with(kGroups[group].instead)) {
      ++group;
    }
    // Groups with the same words count together.
    while (group > 0 && kGroups[group].one == kGroups[group - 1].one) --group;
    // Servers without groups leave the count at 0.
    counts[group] += std::max<std::uint64_t>(1, remark.count());
  }
  std::string text;
  for (std::size_t group = 0; group < std::size(kGroups); ++group) {
    if (counts[group] == 0) continue;
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", counts[group],
                        counts[group] == 1 ? kGroups[group].one : kGroups[group].many);
  }
  return text;
}

}  // namespace lucerna::cli
