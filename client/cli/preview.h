// render --tev, --preview: who looks on while a picture is rendered.
//
// Neither holds up the rendering: tev has a thread that sends to it (client/view/tev.h), files one
// that draws them, and both keep what is newest and no more.
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <vector>

#include "client/files/write_picture.h"
#include "client/jobs/picture.h"
#include "client/view/tev.h"

namespace lucerna::cli {

struct PreviewOption {
  std::string tev{};    ///< empty: not asked for
  double redraw_s = 0;  ///< 0: not asked for
  std::string redraw_text{};

  void add(CLI::App& command);
};

/// Shows one picture after the other.
class Preview {
 public:
  /// Ends the program where --tev is no address or --preview has no PNG to redraw.
  Preview(const PreviewOption& option, const std::vector<std::string>& outputs);
  Preview(const Preview&) = delete;
  Preview& operator=(const Preview&) = delete;
  ~Preview();

  /// Whether anybody looks on; if not, nothing below does anything.
  explicit operator bool() const { return sender_ != nullptr || redraw_s_ > 0; }

  /// A new picture.  The PNGs among `files` are redrawn, which nobody else may touch until
  /// files_done().  In tev it has the name of the first file.
  void begin(std::vector<client::PictureFile>& files, double exposure_ev);
  /// A tile has become part of it.
  void update(const v1::Tile& tile, const client::PictureAssembler& so_far);
  /// The files are not redrawn any more.
  void files_done();
  /// After the files are written: gives tev a little time to get the rest.
  void finish();

 private:
  class Redraw;

  double redraw_s_;
  std::unique_ptr<client::TevSender> sender_;
  std::string name_;
  bool begun_ = false;  // tev knows of the picture
  std::unique_ptr<Redraw> redraw_;
};

}  // namespace lucerna::cli
