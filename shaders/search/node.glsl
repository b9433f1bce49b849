// A node of the hierarchy: bounds of the seeds below it, in units. Without seeds its lower bounds are the largest numbers.
struct Node {
    uvec2 lower[3];
    uvec2 upper[3];
};
