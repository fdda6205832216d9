#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>

namespace diaphane::api::load {

/// Name, with its labels as they are written, to value.
using Samples = std::map<std::string, double>;

/// The Prometheus text format, without its comments.
Samples parse_metrics(std::string_view text);
/// GET /metrics of 127.0.0.1; empty when nobody answers within 2 s.
Samples scrape(std::uint16_t port);
/// Whether /readyz of 127.0.0.1 answers 200.
bool ready(std::uint16_t port);

double value_of(const Samples& samples, const std::string& name);

}  // namespace diaphane::api::load
