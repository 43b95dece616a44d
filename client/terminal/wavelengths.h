// --wavelength: values at single wavelengths, beside RGB.
#pragma once

#include <string>
#include <vector>

#include "client/terminal/output.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

class WavelengthOption {
 public:
  void add(CLI::App& command);

  bool given() const { return !nm_.empty(); }

  template <typename Request>
  void put(Request& request) const {
    request.mutable_wavelengths_nm()->Add(nm_.begin(), nm_.end());
  }

  /// The values' column: "at 450 555 nm", or with a unit "at 450 555 nm [W/nm]".  In CSV each
  /// wavelength has a column.
  Table::Column column(const std::string& unit = {}) const;

  /// The values of item `i`, with spaces between them.
  template <typename T>
  Cell values(const google::protobuf::RepeatedField<T>& all, int i) const {
    std::string text;
    std::vector<std::string> values;
    const int count = static_cast<int>(nm_.size());
    for (int k = i * count; k < (i + 1) * count && k < all.size(); ++k) {
      const Cell cell = number_cell(all[k]);
      if (!text.empty()) text += ' ';
      text += cell.text();
      values.push_back(cell.values().front());
    }
    return {std::move(text), std::move(values)};
  }

 private:
  std::vector<double> nm_;
};

}  // namespace lucerna::cli
