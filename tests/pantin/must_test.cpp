// What must() does where there is no value: it ends the program, here one that was forked.
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <pantin/must.hpp>
#include <string>
#include <vector>

using namespace pantin;

namespace {

struct Ended {
  int status = -1;   // of its exit
  std::string told;  // on stderr
};

/// Leaves at once: what the runner of the tests would do at its end is not for the child.
void leave(int status, void*) {
  std::fflush(stderr);
  ::_exit(status);
}

/// Runs a program in a child of its own.
Ended run(void (*program)()) {
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  std::fflush(stdout), std::fflush(stderr);
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    ::dup2(ends[1], STDERR_FILENO);
    ::close(ends[0]), ::close(ends[1]);
    ::on_exit(leave, nullptr);
    program();
    ::_exit(0);
  }
  ::close(ends[1]);
  Ended ended;
  char piece[256];
  for (ssize_t got; (got = ::read(ends[0], piece, sizeof piece)) > 0;)
    ended.told.append(piece, static_cast<std::size_t>(got));
  ::close(ends[0]);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  if (WIFEXITED(status)) ended.status = WEXITSTATUS(status);
  return ended;
}

}  // namespace

TEST_CASE("must() prints every error, a line each, and ends the program with status 2") {
  const Ended ended = run([] {
    must(Result<int>(std::vector<Error>{{"BallJoint: a: found no entity"}, {"and 50 % more"}}));
  });
  CHECK(ended.status == 2);
  CHECK(ended.told == "BallJoint: a: found no entity\nand 50 % more\n");
}

TEST_CASE("must() gives the value where there is one, also one that cannot be copied") {
  const Ended ended = run([] {
    if (*must(Result<std::unique_ptr<int>>(std::make_unique<int>(7))) != 7) ::_exit(1);
  });
  CHECK(ended.status == 0);
  CHECK(ended.told.empty());
}
