#pragma once

// What the commands that serve a page share.

#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "engine/viewer/view_server.h"

namespace palpate {

// --port.
CLI::Option* add_port(CLI::App& app, ServerSettings& settings);

// As a browser on this machine writes it, with the token of a role.
std::string page_address(const ServerSettings& settings, const ViewServer& server,
                         PageRole role = kMainPage);

// The error of a program without its page. command: such as "view".
Error no_page(const std::string& command = "view");

// ViewServer::listen() with as many open files as the system allows. An error names the option.
Result<std::unique_ptr<ViewServer>> listen_for_pages(const ServerSettings& settings,
                                                     const PageFiles& page, ViewModel& model);

}  // namespace palpate
