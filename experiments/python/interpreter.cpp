// A Python with the module `etendue` built in: takes what `python3` takes.
#include <Python.h>

extern "C" PyObject* PyInit_etendue();

int main(int argc, char** argv) {
  if (PyImport_AppendInittab("etendue", PyInit_etendue) != 0) return 2;
  return Py_BytesMain(argc, argv);
}
