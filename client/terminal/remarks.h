// Describes in words the content of a scene file that Lucerna does not model.
#pragma once

#include <google/protobuf/repeated_field.h>

#include <string>

#include "lucerna/v1/scene.pb.h"

namespace lucerna::cli {

/// "file:line:column: what; instead".  With the number of further places: "file:line:column and 3
/// more places: what; instead".
std::string describe(const v1::Remark& remark);

/// Counts remarks, each at all its places, by the server's replacement: "2 surfaces left out, 3
/// materials taken as diffuse, 1 other remark".  Empty for no remarks.
std::string count_remarks(const google::protobuf::RepeatedPtrField<v1::Remark>& remarks);

}  // namespace lucerna::cli
