#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "api/scans/data_sets.h"
#include "api/shared/secrets.h"
#include "common/config.h"
#include "common/service/admin_server.h"
#include "common/visitor_share.h"
#include "common/wire/inner_tls.h"

namespace diaphane::api {

/// Settings of the REST API.
struct Settings {
  std::string postgres, redis, public_url, upload_dir, volume_dir, cache_dir, mail, mail_from;
  std::string consent_version;  ///< of the privacy notice
  std::string sample_token, fleet;
  std::optional<SealingKey> factor_key;
  std::uint16_t api_port = 0;
  service::AdminServer::Options admin;
  DataSets::Options data_sets;
  std::int64_t export_total_bytes = 0;
  std::chrono::milliseconds background{5000};
  int visitor_percent = kVisitorPercent;
  std::string study_analysis_url;  ///< of the analysis of studies; empty if it is not installed
  std::string archive_url;         ///< of the PACS gateway; empty if it is not installed
  std::string archive_key;         ///< the secret that api and the PACS gateway share
  wire::InnerTls tls;
};

Settings read_settings(ConfigReader& in);

}  // namespace diaphane::api
