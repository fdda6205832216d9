#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace diaphane::api::load {

/// Values by name, including the labels as written.
using Samples = std::map<std::string, double>;

/// Parses the Prometheus text format and ignores comments.
Samples parse_metrics(std::string_view text);
/// Requests /metrics from 127.0.0.1. Returns an empty map if there is no response within 2 s.
Samples scrape(std::uint16_t port);
/// Returns whether /readyz on 127.0.0.1 returns 200.
bool ready(std::uint16_t port);

double value_of(const Samples& samples, const std::string& name);

}  // namespace diaphane::api::load
