// Would not pass the warnings that pantin is compiled with.
int main() {
  double big = 1.5;
  int small = big;
  {
    int big = 2;
    small += big - 3;
  }
  return small;
}
