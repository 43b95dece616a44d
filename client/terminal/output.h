// Answers as aligned tables for people and as JSON for programs.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <string_view>
#include <vector>

#include "lucerna/v1/lighting.pb.h"

namespace lucerna::cli {

/// Rows of text under headers.  Columns are as wide as their widest entry, with two spaces between
/// them.
class Table {
 public:
  struct Column {
    std::string header;
    bool text = false;  ///< aligned left; numbers are aligned right
  };
  explicit Table(std::vector<Column> columns);

  void add(std::vector<std::string> row);
  std::string to_string() const;

 private:
  std::vector<Column> columns_;
  std::vector<std::vector<std::string>> rows_;
};

/// Six significant digits.
std::string number(double value);
/// Three numbers with spaces between them: "a b c".
std::string triple(double a, double b, double c);
/// Triple `i` of an interleaved array; "" beyond its end.
std::string triple_of(const google::protobuf::RepeatedField<float>& values, std::size_t i);
/// The unit vector along `v` to four decimals, which is 0.003 degrees: "0 0.7071 -0.7071".
std::string direction(const v1::Vector3& v);

/// The message as protocol-buffers JSON on one line, with a new line.  Field names are
/// lowerCamelCase; fields without presence are always written.  `more` has further members,
/// `"name":value` with commas between them, which come last.
std::string to_json(const google::protobuf::Message& message, const std::string& more = {});

/// The name of the item's status, such as "INVALID_INPUT"; empty for OK.  An empty `statuses` means
/// that all items are OK.
std::string item_status(const google::protobuf::RepeatedField<int>& statuses, std::size_t item);
/// Whether the item has an answer.  Points inside solids have an answer.
bool has_answer(const google::protobuf::RepeatedField<int>& statuses, std::size_t item);
/// Whether some item has no answer.  Items without light have an answer.
bool any_failed(const google::protobuf::RepeatedField<int>& statuses);

/// "2 of 8 points are inside of solids; ".  Empty if none is.
std::string describe_inside(const google::protobuf::RepeatedField<int>& statuses);

/// "1.2 s, 4096 samples, 8192 rays".  describe_approximations() reports wrong look-ups in shadow
/// maps.
std::string describe(const v1::Cost& cost);

}  // namespace lucerna::cli
