#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

#include "common/config.h"
#include "common/service/admin_server.h"
#include "common/visitor_share.h"
#include "common/wire/inner_tls.h"
#include "renderd/engine/frame_renderer.h"
#include "renderd/schedule/policy.h"
#include "renderd/serve/still_service.h"

namespace diaphane::render {

/// Settings of renderd.
struct Settings {
  std::string worker_id;
  std::string redis;
  std::string grpc_address;
  std::uint16_t grpc_port = 0;
  std::string advertise;
  service::AdminServer::Options admin;
  std::string volume_dir;
  EngineChoice engine = EngineChoice::kAuto;
  unsigned threads = 0;
  std::size_t slots = 0;
  int visitor_percent = kVisitorPercent;
  double max_error = 0;  ///< relative error at which a picture counts as converged
  std::uint32_t still_samples = StillService::kMostSamples;
  std::uint64_t volume_bytes = 0;
  std::uint64_t texture_bytes = 0;
  std::string copies_dir;
  std::uint64_t copies_bytes = 0;
  PolicyKind policy = PolicyKind::kMarginalGain;
  /// Watchdog limit for the device and the main loop; 0: no watchdog.
  std::chrono::seconds silence{0};
  EngineOptions options;
  bool mark_frames = false;
  std::vector<int> devices;  ///< empty: all that are visible
  std::vector<std::string> assist;
  std::size_t lend = 0;
  bool lend_spare = false;
  std::string owner;
  std::string node;
  wire::InnerTls tls;
};

Settings read_settings(ConfigReader& in);

}  // namespace diaphane::render
