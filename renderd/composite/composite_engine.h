#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "renderd/composite/composite_renderer.h"

namespace diaphane::render {

/// Data that an assistant in another process needs before its first task.
struct AssistOrder {
  std::string volume_id;    ///< id in the volume store
  bool with_table = false;  ///< the volume shows what surrounds the body
  std::uint32_t phase = 0;  ///< phase of the scan
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

/// Several devices that render pictures together. A picture has a home device, which shows it and
/// merges what the other devices add to it in turns. As an Engine, it gives all pictures the first
/// device as their home.
class CompositeEngine : public Engine {
 public:
  virtual std::size_t devices() const = 0;
  /// Returns this engine with another home device. All homes share the volumes.
  virtual Engine& home(std::size_t device) = 0;
  /// Sets `needed`: a device helps no other while the function is true for it. Several threads call
  /// it, and it must not wait. The previous function is never called after this returns.
  virtual void keep_for_own(std::function<bool(std::size_t device)> needed) = 0;
};

/// Makes an engine of at least one device. `source` adds assistants of other processes; it may be
/// null and must outlive the engine.
std::unique_ptr<CompositeEngine> make_composite_engine(std::vector<std::unique_ptr<Engine>> devices,
                                                       AssistSource* source,
                                                       CompositeOptions options = {});

/// Makes a renderer for another worker's picture. It uses only the home device, so that assistants
/// do not request assistants themselves. `engine` may be any engine.
Result<std::unique_ptr<FrameRenderer>> renderer_of_one_device(
    Engine& engine, const std::shared_ptr<const DeviceVolume>& volume, std::uint64_t seed,
    std::uint64_t first_sample, Method method);

}  // namespace diaphane::render
