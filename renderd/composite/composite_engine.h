#pragma once

#include <memory>
#include <string>
#include <vector>

#include "renderd/composite/composite_renderer.h"

namespace diaphane::render {

/// What an assistant in another process must know before its first task.
struct AssistOrder {
  std::string volume_id;  ///< in the volume store
  std::uint64_t seed = 0;
  std::uint64_t first_sample = 0;
  Method method;
};

/// Where assistants of other processes come from. Thread-safe.
class AssistSource {
 public:
  virtual ~AssistSource() = default;
  /// One for each that is known, there or not: it says itself when it is lost.
  virtual std::vector<std::unique_ptr<Assistant>> assistants(const AssistOrder& order) = 0;
};

/// An engine whose pictures are rendered by several devices: those of this process, of which the
/// first shows the picture and the others take turns between all pictures, and those of `source`
/// (may be null; outlives the engine). To its caller it is the first device.
std::unique_ptr<Engine> make_composite_engine(std::vector<std::unique_ptr<Engine>> devices,
                                              AssistSource* source, CompositeOptions options = {});

/// For another worker's picture: of the first device alone, so that assistants ask nobody to assist
/// them. `engine` may be any.
Result<std::unique_ptr<FrameRenderer>> renderer_of_one_device(
    Engine& engine, const std::shared_ptr<const DeviceVolume>& volume, std::uint64_t seed,
    std::uint64_t first_sample, Method method);

}  // namespace diaphane::render
