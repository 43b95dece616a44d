// Answers for people, as aligned tables, and for machines, as JSON.
#pragma once

#include <google/protobuf/message.h>

#include <string>
#include <string_view>
#include <vector>

#include "lucerna/v1/lighting.pb.h"

namespace lucerna::cli {

/// Rows of text under headers, columns as wide as their widest entry, two spaces between.
class Table {
 public:
  struct Column {
    std::string header;
    bool text = false;  ///< to the left; numbers stand to the right
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
/// "a b c"
std::string triple(double a, double b, double c);
/// The unit vector along `v` to four decimals, which is 0.003 degrees: "0 0.7071 -0.7071".
std::string direction(const v1::Vector3& v);

/// The message as the protocol-buffers JSON of one line, fields named as in the .proto file, those
/// without presence always written, and a new line.  `more`: what the message does not hold,
/// `"name":value` with commas between, behind it.
std::string to_json(const google::protobuf::Message& message, const std::string& more = {});

/// "INVALID_INPUT"; empty for OK.  `statuses` may be empty, for all OK.
std::string item_status(const google::protobuf::RepeatedField<int>& statuses, std::size_t item);
/// Where some item has no answer, rather than the answer that there is no light.
bool any_failed(const google::protobuf::RepeatedField<int>& statuses);

/// "1.2 s, 4096 samples, 8192 rays"; how many look-ups in shadow maps are wrong is told by
/// describe_approximations().
std::string describe(const v1::Cost& cost);

}  // namespace lucerna::cli
