#include "renderd/serve/file_maker.h"

#include <algorithm>
#include <cmath>

#include "common/try.h"
#include "renderd/encode/png_rows.h"
#include "renderd/encode/video_file.h"
#include "renderd/film/part.h"
#include "renderd/scene/file_order.h"
#include "renderd/scene/video_path.h"

namespace diaphane::render {
namespace {

namespace v1 = diaphane::v1;

constexpr std::uint32_t kMostSamples = 1 << 16;
// With fewer samples, the error estimate is unreliable.
constexpr std::uint32_t kFewestSamples = 16;
/// Largest side of the small picture that predicts the samples of a large one.
constexpr std::uint32_t kTrialSide = 768;
constexpr int kPngLevelOfFiles = 6;  // encoded once, kept for long

class VideoMaker final : public FileMaker {
 public:
  VideoMaker(v1::Video video, std::vector<v1::Scene> keys, std::unique_ptr<VideoFile> file,
             FileMarks marks, std::uint32_t phases)
      : video_(std::move(video)),
        keys_(std::move(keys)),
        file_(std::move(file)),
        marks_(std::move(marks)),
        phases_(phases) {}

  std::optional<FileStep> next() override {
    if (taken_ == video_.frames()) return std::nullopt;
    return FileStep{std::make_shared<const v1::Scene>(frame()),
                    {video_.width(), video_.height()},
                    kMostSamples,
                    video_.error(),
                    true};
  }
  Result<std::string> take(const PictureRgb8& picture, std::uint64_t) override {
    if (marks_.empty()) {
      DIAPHANE_TRY(file_->add(picture));
    } else {
      PictureRgb8 marked = picture;
      marks_.draw(marked, frame());
      DIAPHANE_TRY(file_->add(marked));
    }
    ++taken_;
    return std::string();  // the index comes first in the file, but is known last
  }
  Result<std::string> finish() override { return file_->finish(); }
  double done() const override { return static_cast<double>(taken_) / video_.frames(); }

 private:
  v1::Scene frame() const { return video_frame(video_, keys_, taken_, phases_); }

  const v1::Video video_;
  const std::vector<v1::Scene> keys_;
  const std::unique_ptr<VideoFile> file_;
  const FileMarks marks_;
  const std::uint32_t phases_;
  std::uint32_t taken_ = 0;
};

// First renders a small picture of the whole to the target error. This determines the number of
// samples, which is the same for each band. If each band had its own target error, darker bands
// would be noisier.
class PictureMaker final : public FileMaker {
 public:
  PictureMaker(Canvas size, double error, v1::Scene scene, std::unique_ptr<PngRows> file,
               FileMarks marks)
      : size_(size),
        error_(error),
        scene_(std::make_shared<const v1::Scene>(std::move(scene))),
        file_(std::move(file)),
        marks_(std::move(marks)),
        trial_(trial_of(size)) {}

  std::optional<FileStep> next() override {
    if (samples_ == 0) return FileStep{scene_, trial_, kMostSamples, error_, false};
    if (row_ == size_.height) return std::nullopt;
    const std::uint32_t rows = std::min(band_rows(size_), size_.height - row_);
    return FileStep{scene_, {size_.width, rows, row_, size_.height}, samples_, 0, false};
  }
  Result<std::string> take(const PictureRgb8& picture, std::uint64_t samples) override {
    if (samples_ == 0) {
      samples_ = static_cast<std::uint32_t>(
          std::clamp<std::uint64_t>(samples, kFewestSamples, kMostSamples));
      return std::string();
    }
    auto bytes = marks_.empty() ? file_->add(picture.pixels) : file_->add(marked(picture));
    if (bytes) row_ += picture.size.height;
    return bytes;
  }
  Result<std::string> finish() override { return file_->finish(); }
  double done() const override {
    const double trial = pixels(trial_), all = trial + pixels(size_);
    if (samples_ == 0) return 0;
    return (trial + double(size_.width) * row_) / all;
  }

 private:
  std::vector<std::uint8_t> marked(PictureRgb8 band) const {
    band.size.first_row = row_;
    band.size.whole_height = size_.height;
    marks_.draw(band, *scene_);
    return std::move(band.pixels);
  }
  static double pixels(Canvas canvas) { return double(canvas.width) * canvas.height; }
  static Canvas trial_of(Canvas size) {
    const double shrunk = std::min(1.0, double(kTrialSide) / std::max(size.width, size.height));
    const auto side = [&](std::uint32_t length) {
      return std::max(1u, static_cast<std::uint32_t>(std::lround(length * shrunk)));
    };
    return {side(size.width), side(size.height)};
  }

  const Canvas size_;
  const double error_;
  const std::shared_ptr<const v1::Scene> scene_;
  const std::unique_ptr<PngRows> file_;
  const FileMarks marks_;
  const Canvas trial_;
  std::uint32_t samples_ = 0;  // 0: not yet known
  std::uint32_t row_ = 0;
};

Result<std::unique_ptr<FileMaker>> video_maker(const v1::Video& video, std::vector<v1::Scene> keys,
                                               FileMarks marks, std::uint32_t phases) {
  DIAPHANE_TRY(check_video(video, keys, phases));
  auto file =
      make_video_file({{video.width(), video.height()}, video.frames_per_second(), video.frames()});
  DIAPHANE_TRY(file);
  return std::make_unique<VideoMaker>(video, std::move(keys), std::move(*file), std::move(marks),
                                      phases);
}

Result<std::unique_ptr<FileMaker>> picture_maker(const v1::LargePicture& picture,
                                                 std::vector<v1::Scene> keys, FileMarks marks) {
  DIAPHANE_TRY(check_picture(picture, keys));
  const Canvas size{picture.width(), picture.height()};
  auto file = make_png_rows(size, kPngLevelOfFiles);
  DIAPHANE_TRY(file);
  return std::make_unique<PictureMaker>(size, picture.error(), std::move(keys.front()),
                                        std::move(*file), std::move(marks));
}

}  // namespace

std::uint32_t band_rows(Canvas picture) {
  const auto fitting =
      static_cast<std::uint32_t>(kBandPixels / picture.width) / kShareRows * kShareRows;
  return std::clamp(fitting, kShareRows, std::max(picture.height, kShareRows));
}

Result<std::unique_ptr<FileMaker>> make_file_maker(const v1::FileRequest& request,
                                                   std::vector<v1::Scene> keys, FileMarks marks,
                                                   std::uint32_t phases) {
  DIAPHANE_TRY(check_mark_unit(request));
  if (request.has_video()) {
    return video_maker(request.video(), std::move(keys), std::move(marks), phases);
  }
  if (request.has_picture()) {
    return picture_maker(request.picture(), std::move(keys), std::move(marks));
  }
  return fail(ErrorCode::kInvalid, "This file type is not supported.", "kind");
}

}  // namespace diaphane::render
