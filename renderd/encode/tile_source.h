#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <utility>

#include "renderd/encode/encode_pool.h"
#include "renderd/encode/tiles.h"

namespace diaphane::render {

/// The tiles of one finished picture, each encoded once for all receivers when the first of them is
/// about to need it. Destroying the source cancels the rest of the encoding. Thread-safe.
class TileSource : public std::enable_shared_from_this<TileSource> {
 public:
  /// `ready` is called without a lock from an encoding thread when a tile has been encoded.
  TileSource(EncodePool& pool, PictureRgb8 picture, std::function<void()> ready);

  const std::vector<Tile>& tiles() const { return tiles_; }
  /// Returns the tile, or null while it is being encoded or if it could not be (see failed()).
  std::shared_ptr<const CodedTile> get(std::size_t index, diaphane::v1::StillFormat format);
  /// Whether a tile could not be encoded, so that there will be no lossless picture.
  bool failed() const;

 private:
  using Key = std::pair<diaphane::v1::StillFormat, std::size_t>;
  void code(const Key& key);

  EncodePool& pool_;
  const PictureRgb8 picture_;
  const std::vector<Tile> tiles_;
  const std::function<void()> ready_;
  mutable std::mutex mutex_;
  std::map<Key, std::shared_ptr<const CodedTile>> coded_;
  std::set<Key> under_way_;
  bool failed_ = false;
};

}  // namespace diaphane::render
