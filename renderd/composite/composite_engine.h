#pragma once

#include <memory>
#include <string>
#include <vector>

#include "renderd/composite/composite_renderer.h"

namespace diaphane::render {

/// Data that an assistant in another process needs before its first task.
struct AssistOrder {
  std::string volume_id;    ///< id in the volume store
  bool with_table = false;  ///< the volume shows what surrounds the body
  std::uint64_t seed = 0;
  std::uint64_t first_sample = 0;
  Method method;
};

/// Provides assistants of other processes. Thread-safe.
class AssistSource {
 public:
  virtual ~AssistSource() = default;
  /// Returns one assistant per known worker, reachable or not (see Assistant::lost()).
  virtual std::vector<std::unique_ptr<Assistant>> assistants(const AssistOrder& order) = 0;
};

/// Makes an engine whose pictures are rendered by several devices. The first of `devices` shows the
/// pictures, and the others take turns between all pictures. `source` adds assistants of other
/// processes; it may be null and must outlive the engine. To its caller the engine looks like the
/// first device.
std::unique_ptr<Engine> make_composite_engine(std::vector<std::unique_ptr<Engine>> devices,
                                              AssistSource* source, CompositeOptions options = {});

/// Makes a renderer for another worker's picture. It uses only the first device, so that assistants
/// do not request assistants themselves. `engine` may be any engine.
Result<std::unique_ptr<FrameRenderer>> renderer_of_one_device(
    Engine& engine, const std::shared_ptr<const DeviceVolume>& volume, std::uint64_t seed,
    std::uint64_t first_sample, Method method);

}  // namespace diaphane::render
