#pragma once

#include "common/result.h"
#include "renderd/film/part.h"

namespace diaphane::render {

/// Exchanges the samples of one picture among several devices (renderd/composite). The default
/// functions fail with kUnsupported, for engines that render only whole pictures.
class FilmExchange {
 public:
  virtual ~FilmExchange() = default;

  /// Sets the share of the picture that is rendered from the next sample. The film keeps its
  /// samples, and its progress counts the pixels with the fewest samples. A new scene begins with
  /// the whole picture. Fails with kConflict unless all rows of the previous share have the same,
  /// even number of samples of their own, as after a whole batch of an even number.
  virtual Result<void> set_share(const Share&) { return no_shares(); }
  /// Moves the samples since the last call out of the film, so that another film can merge them.
  /// Returns false and moves nothing if there are no samples, if their number per pixel is odd, or
  /// if it differs between rows after a stopped batch.
  virtual Result<bool> take_film(FilmPart&) { return no_shares(); }
  /// Works like take_film(), for another device of the same kind of engine in this process. The
  /// pixels may stay in device memory (FilmPart::on_device).
  virtual Result<bool> take_film_here(FilmPart& out) { return take_film(out); }
  /// Adds samples of another device for the same scene and canvas. Fails with kInvalid if the part
  /// does not fit.
  virtual Result<void> merge_film(const FilmPart&) { return no_shares(); }

 private:
  static tl::unexpected<Error> no_shares() {
    return fail(ErrorCode::kUnsupported, "this device renders whole pictures only");
  }
};

}  // namespace diaphane::render
