char huge[1ul << 32] = {1};
