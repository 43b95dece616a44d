// Answers as aligned tables for people, and as JSON and CSV for programs.
#pragma once

#include <google/protobuf/message.h>

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "client/terminal/colour.h"
#include "lucerna/v1/lighting.pb.h"
#include "proto/common/plain_text.h"

namespace lucerna::cli {

/// An entry of a table: a text for people, and values in full precision for programs.
class Cell {
 public:
  Cell() = default;
  /// The value is the text itself.
  Cell(std::string text) : text_(std::move(text)) {}  // NOLINT: any text is a cell
  Cell(const char* text) : text_(text) {}             // NOLINT
  Cell(std::string text, std::vector<std::string> values)
      : text_(std::move(text)), values_(std::move(values)) {}
  static Cell coloured(std::string text, shell::Colour colour) {
    Cell cell(std::move(text));
    cell.colour_ = colour;
    return cell;
  }

  /// A cell of a table is one line, whatever a server put into it.  Values keep new lines.
  void make_plain() {
    values_ = values();
    for (std::string& value : values_) value = plain_text(value);
    text_ = plain_line(text_);
  }

  const std::string& text() const { return text_; }
  shell::Colour colour() const { return colour_; }
  std::vector<std::string> values() const {
    return values_.empty() ? std::vector<std::string>{text_} : values_;
  }

 private:
  std::string text_;
  std::vector<std::string> values_;
  shell::Colour colour_ = shell::Colour::kPlain;
};

/// Rows of cells under headers.
class Table {
 public:
  struct Column {
    std::string header;
    bool text = false;  ///< aligned left; numbers are aligned right
    /// The names in CSV, one for each value of a cell.  Empty: they follow from the header.
    std::vector<std::string> names = {};
  };
  explicit Table(std::vector<Column> columns);

  void add(std::vector<Cell> row);
  /// Columns are as wide as their widest entry, with two spaces between them.  With `colours`,
  /// headers are bold, and entries of a column without header are warnings.
  std::string to_string(bool colours = false) const;
  /// CSV [RFC 4180] with a header, but with lines that end in LF.  A cell of three values has three
  /// columns: "RGB [lx]" becomes R [lx], G [lx] and B [lx], and "wi" becomes wi x, wi y and wi z.
  /// A column without header is "status", and "± [lx]" is "error [lx]".
  std::string to_csv() const;

 private:
  std::vector<std::string> names_of(std::size_t column) const;

  std::vector<Column> columns_;
  std::vector<std::vector<Cell>> rows_;
};

/// Six significant digits.
std::string number(double value);
/// Six significant digits for people.  The value reads back as the same number.
Cell number_cell(double value);
Cell number_cell(float value);
/// Three numbers, as three values.
Cell triple_cell(double a, double b, double c);
Cell triple_cell(float a, float b, float c);
/// Triple `i` of an interleaved array; an empty cell beyond its end.
Cell triple_cell_of(const google::protobuf::RepeatedField<float>& values, std::size_t i);

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
/// Whether an item with this status has an answer.  Points inside solids have one, and points that
/// may miss light.
bool is_answered(int status);
bool has_answer(const google::protobuf::RepeatedField<int>& statuses, std::size_t item);
/// Whether some item has no answer.  Items without light have an answer.
bool any_failed(const google::protobuf::RepeatedField<int>& statuses);

/// "light by way of room.pbrt:12:1 may be missed at 4 of 8 points; ".  Empty if none has the status
/// MAY_MISS_LIGHT.
std::string describe_missed(const v1::EstimateIrradianceResponse& response);
/// The same for `points` of `all` points.  `surfaces`: the places of the surfaces.
std::string describe_missed(std::uint64_t points, std::uint64_t all,
                            const std::set<std::string>& surfaces);
/// "2 of 8 points are inside of solids or behind lamps; ".  Empty if none is.
std::string describe_inside(const google::protobuf::RepeatedField<int>& statuses);

/// "1.2 s, 4096 samples, 8192 rays".  describe_approximations() reports wrong look-ups in shadow
/// maps.
std::string describe(const v1::Cost& cost);

}  // namespace lucerna::cli
