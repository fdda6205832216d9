#pragma once

#include <functional>
#include <string>
#include <vector>

#include "api/proto/stream.pb.h"
#include "common/result.h"
#include "renderd/encode/mark_brush.h"
#include "renderd/math/vector.h"

namespace diaphane::render {

/// Returns for each place whether it is hidden in a picture of the scene (hidden_places).
using FindHidden = std::function<std::vector<bool>(const diaphane::v1::Scene& scene, Canvas canvas,
                                                   const std::vector<Double3>& places)>;

/// The marks that are drawn into a file, as the page shows them (frontend/src/marks/shapes.ts).
class FileMarks {
 public:
  FileMarks() = default;
  /// Prepares marks that have passed note_file_mark. `unit`: pixels of the file per pixel of the
  /// page; 0 means 1. Fails with kInvalid if the coverage of a label is damaged.
  static Result<FileMarks> make(std::vector<diaphane::v1::FileMark> marks, double unit,
                                FindHidden find_hidden);

  bool empty() const { return marks_.empty(); }
  /// Draws the marks on a picture of the scene, or on a band of it. Thread-safe.
  void draw(PictureRgb8& picture, const diaphane::v1::Scene& scene) const;

 private:
  struct Label {
    std::string outline, letters;  ///< coverage
  };

  void draw_label(PictureRgb8& picture, std::size_t index, PicturePoint start,
                  double opacity) const;

  std::vector<diaphane::v1::FileMark> marks_;
  std::vector<Label> labels_;
  std::vector<Double3> places_;
  double unit_ = 1;
  FindHidden find_hidden_;
};

}  // namespace diaphane::render
