// verify() over ranks: it passes correct results, and finds damage on one rank or on two.
#pragma once

#include <mpi.h>

#include <string>
#include <vector>

namespace test {

// Returns the failures on this rank, one line each. Collective.
std::vector<std::string> check_verify(MPI_Comm comm);

}  // namespace test
