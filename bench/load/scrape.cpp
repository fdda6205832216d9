#include "bench/load/scrape.h"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <cstdlib>
#include <optional>

namespace diaphane::api::load {
namespace {

namespace beast = boost::beast;
namespace http = beast::http;

struct Answer {
  unsigned status = 0;
  std::string body;
};

Answer get(std::uint16_t port, const std::string& path) {
  boost::asio::io_context io;
  beast::tcp_stream stream(io);
  stream.expires_after(std::chrono::seconds(2));
  http::request<http::empty_body> request(http::verb::get, path, 11);
  request.set(http::field::host, "localhost");
  request.set(http::field::connection, "close");
  beast::flat_buffer buffer;
  http::response<http::string_body> response;
  Answer answer;
  stream.async_connect(
      {boost::asio::ip::address_v4::loopback(), port}, [&](beast::error_code no_connection) {
        if (no_connection) return;
        http::async_write(stream, request, [&](beast::error_code not_sent, std::size_t) {
          if (not_sent) return;
          http::async_read(stream, buffer, response, [&](beast::error_code error, std::size_t) {
            if (!error) answer = {response.result_int(), response.body()};
          });
        });
      });
  io.run();
  return answer;
}

}  // namespace

Samples parse_metrics(std::string_view text) {
  Samples samples;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line.front() == '#') continue;
    // Labels may contain blanks, and the value follows them.
    const std::size_t labels = line.rfind('}');
    const std::size_t blank = line.find(' ', labels == std::string::npos ? 0 : labels);
    if (blank == std::string::npos) continue;
    samples[line.substr(0, blank)] = std::strtod(line.c_str() + blank, nullptr);
  }
  return samples;
}

Samples scrape(std::uint16_t port) {
  const Answer answer = get(port, "/metrics");
  return answer.status == 200 ? parse_metrics(answer.body) : Samples{};
}

bool ready(std::uint16_t port) { return get(port, "/readyz").status == 200; }

double value_of(const Samples& samples, const std::string& name) {
  const auto found = samples.find(name);
  return found == samples.end() ? 0 : found->second;
}

}  // namespace diaphane::api::load
