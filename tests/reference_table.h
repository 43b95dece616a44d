// Tables of tests/data/extremes: numbers computed with 60 digits and stored with 30.
#pragma once

#include <cstddef>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/paths.h"

namespace lucerna::testing {

class ReferenceTable {
 public:
  class Row {
   public:
    Row(const std::map<std::string, std::size_t>& columns, std::vector<std::string> words)
        : columns_(columns), words_(std::move(words)) {}
    /// The double nearest to the value in the column.  Throws if there is no such column.
    double operator[](const std::string& column) const { return std::stod(text(column)); }
    const std::string& text(const std::string& column) const {
      return words_.at(columns_.at(column));
    }

   private:
    const std::map<std::string, std::size_t>& columns_;
    std::vector<std::string> words_;
  };

  /// Reads tests/data/extremes/`name`.txt.  Lines that begin with # are comments; the first other
  /// line names the columns.  Throws if the file does not exist or a line has a wrong number of
  /// words.
  explicit ReferenceTable(const std::string& name) {
    const std::string path = test_data("extremes/") + name + ".txt";
    std::ifstream file(path);
    if (!file) throw std::runtime_error("cannot open " + path);
    std::string line;
    while (std::getline(file, line)) {
      if (line.empty() || line[0] == '#') continue;
      std::istringstream in(line);
      std::vector<std::string> words;
      for (std::string word; in >> word;) words.push_back(word);
      if (columns_.empty()) {
        for (std::size_t i = 0; i < words.size(); ++i) columns_[words[i]] = i;
      } else if (words.size() != columns_.size()) {
        throw std::runtime_error(path + ": " + line);
      } else {
        rows_.emplace_back(columns_, std::move(words));
      }
    }
    if (rows_.empty()) throw std::runtime_error(path + " holds no rows");
  }
  ReferenceTable(const ReferenceTable&) = delete;
  ReferenceTable& operator=(const ReferenceTable&) = delete;

  const std::vector<Row>& rows() const { return rows_; }

 private:
  std::map<std::string, std::size_t> columns_;
  std::vector<Row> rows_;
};

}  // namespace lucerna::testing
