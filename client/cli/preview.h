// render --tev and --preview: shows a picture while it is rendered.
//
// Neither slows the rendering.  One thread sends pixels to tev (client/library/tev.h), and another
// draws the files.  Both keep only the newest pixels.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "client/files/write_picture.h"
#include "client/library/picture.h"
#include "client/library/tev.h"

namespace CLI {
class App;
}

namespace lucerna::cli {

struct PreviewOption {
  std::string tev{};    ///< empty: not given
  double redraw_s = 0;  ///< 0: not given
  std::string redraw_text{};

  void add(CLI::App& command);
};

/// Shows one picture after the other.
class Preview {
 public:
  /// Ends the program if --tev is no address or --preview has no PNG to redraw.
  Preview(const PreviewOption& option, const std::vector<std::string>& outputs);
  Preview(const Preview&) = delete;
  Preview& operator=(const Preview&) = delete;
  ~Preview();

  /// Whether --tev or --preview is given.  If not, the calls below do nothing.
  explicit operator bool() const { return sender_ != nullptr || redraw_s_ > 0; }

  /// Begins a new picture.  It redraws the PNGs among `files`; the caller must not use them until
  /// files_done().  In tev the picture has the name of the first file.
  void begin(std::vector<client::PictureFile>& files, double exposure_ev);
  /// Call it when a tile has become part of the picture.
  void update(const v1::Tile& tile, const client::PictureAssembler& so_far);
  /// Stops redrawing the files.
  void files_done();
  /// Call it when the files are written.  Waits until tev has all pixels, or accepts no byte for
  /// one second.
  void finish();

 private:
  class Redraw;

  double redraw_s_;
  std::unique_ptr<client::TevSender> sender_;
  std::string name_;
  bool begun_ = false;  // tev has the picture
  std::unique_ptr<Redraw> redraw_;
};

}  // namespace lucerna::cli
