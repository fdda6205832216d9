#include <exception>
#include <iostream>
#include <new>

#include "renderd/cli/command.h"

int main(int argc, char** argv) {
  namespace cli = diaphane::render::cli;
  try {
    const auto parsed = cli::parse(argc, argv);
    if (const auto* early_exit = std::get_if<cli::EarlyExit>(&parsed)) {
      (early_exit->exit_code == 0 ? std::cout : std::cerr) << early_exit->text;
      return early_exit->exit_code;
    }
    return cli::run(std::get<cli::Options>(parsed));
  } catch (const std::bad_alloc&) {
    std::cerr << "diaphane-render: not enough memory\n";
    return cli::kExitResources;
  } catch (const std::exception& error) {
    std::cerr << "diaphane-render: " << error.what() << '\n';
    return cli::kExitDefect;
  }
}
