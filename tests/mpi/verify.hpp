// verify() over ranks: it passes what is right, and finds what was damaged on one rank or on two.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

namespace test {

// Returns what is wrong on this rank, one line each. Collective.
std::vector<std::string> check_verify(MPI_Comm comm);

}  // namespace test
