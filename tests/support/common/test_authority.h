#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include "common/ids.h"
#include "common/wire/inner_tls.h"

namespace diaphane::wire {

/// A CA in its own directory, which issues certificates with the openssl command.
class Authority {
 public:
  Authority() : folder_(std::filesystem::temp_directory_path() / ("tls-" + random_hex(8))) {
    std::filesystem::create_directories(folder_);
    run("req -x509 " + key("ca") + " -days 2 -subj /CN=ca-" + random_hex(4) + " -out " +
        path("ca.pem"));
  }
  ~Authority() { std::filesystem::remove_all(folder_); }
  Authority(const Authority&) = delete;
  Authority& operator=(const Authority&) = delete;

  /// Issues a certificate for `names` ("DNS:renderd,IP:127.0.0.1") with trust in this CA. With
  /// negative `days`, it has expired. `usage` is its only extended key usage, if set.
  TlsFiles issue(const std::string& file, const std::string& names, int days = 2,
                 const std::string& usage = "") const {
    run("req " + key(file) + " -new -subj /CN=" + file + " -out " + path(file + ".csr"));
    std::ofstream(path(file + ".ext")) << "subjectAltName=" << names << "\n"
                                       << (usage.empty() ? "" : "extendedKeyUsage=" + usage + "\n");
    run("x509 -req -in " + path(file + ".csr") + " -CA " + path("ca.pem") + " -CAkey " +
        path("ca.key") + " -set_serial 0x" + random_hex(8) + " -days " + std::to_string(days) +
        " -extfile " + path(file + ".ext") + " -out " + path(file + ".pem"));
    return {path("ca.pem"), path(file + ".pem"), path(file + ".key")};
  }
  /// Issues a self-signed certificate with trust in this CA.
  TlsFiles issue_to_itself(const std::string& file, const std::string& names) const {
    run("req -x509 " + key(file) + " -days 2 -subj /CN=" + file +
        " -addext subjectAltName=" + names + " -out " + path(file + ".pem"));
    return {path("ca.pem"), path(file + ".pem"), path(file + ".key")};
  }
  std::string path(const std::string& file) const { return (folder_ / file).string(); }

 private:
  std::string key(const std::string& file) const {
    return "-newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -keyout " + path(file + ".key");
  }
  static void run(const std::string& words) {
    const int code = std::system(("openssl " + words + " 2>/dev/null").c_str());
    if (code != 0) throw std::runtime_error("openssl " + words);
  }

  std::filesystem::path folder_;
};

}  // namespace diaphane::wire
