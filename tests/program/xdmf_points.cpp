// Reads a file by the library beneath ParaView's XDMF reader; prints each grid's time, its number of cells and its points.
// usage: xdmf_points frames.xdmf
#include <XdmfDomain.hpp>
#include <XdmfGeometry.hpp>
#include <XdmfGridCollection.hpp>
#include <XdmfReader.hpp>
#include <XdmfTime.hpp>
#include <XdmfTopology.hpp>
#include <XdmfUnstructuredGrid.hpp>
#include <iostream>
#include <stdexcept>

int main(int count, char** words) try {
  if (count != 2) throw std::invalid_argument("usage: xdmf_points frames.xdmf");
  const auto domain = shared_dynamic_cast<XdmfDomain>(XdmfReader::New()->read(words[1]));
  const auto frames = domain->getGridCollection(0);
  std::cout.precision(17);
  for (unsigned int k = 0; k < frames->getNumberUnstructuredGrids(); ++k) {
    const auto grid = frames->getUnstructuredGrid(k);
    const auto points = grid->getGeometry();
    points->read();
    std::cout << grid->getTime()->getValue() << ' ' << grid->getTopology()->getNumberElements();
    for (unsigned int i = 0; i < points->getSize(); ++i) std::cout << ' ' << points->getValue<double>(i);
    std::cout << '\n';
  }
} catch (const std::exception& e) {
  std::cerr << e.what() << '\n';
  return 1;
}
